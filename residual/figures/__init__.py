"""Figures of the report. Importing its modules imports matplotlib."""
