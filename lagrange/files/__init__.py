"""Files that the commands read and write, whoever has made them."""
