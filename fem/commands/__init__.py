"""The commands. They import little: everything heavy waits until a scene has been read."""
