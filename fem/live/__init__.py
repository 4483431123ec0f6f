"""The reduced model played in a browser's page while it runs.

controls    what viewers may change, and the scene that follows
player      the run that goes on for as long as it is watched; `record`: what its charts show of the past
messages    what player and page tell each other
playing     the thread that advances the player at the pace asked for
server      the page and its messages over the loopback interface
page        the page: template, style, scripts

The run's state belongs to the thread, connections to the server; between them go messages alone.
"""
