"""Pictures, films and fields for other programs, from a result file. Each module says what it holds."""
