"""Readers against changed files; tests/test_fuzz.py draws them.

targets    the readers, each as a function of a file's content, and sound inputs to start from
mutations  inputs that stay near sound ones
"""
