"""The result file, while it is written and after. Each module says what it holds."""
