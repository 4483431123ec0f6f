"""The reduced model played in a browser's page while it runs.

The run's state belongs to a thread (`playing`), connections to the server; between them go messages alone.
"""
