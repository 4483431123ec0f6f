"""A bearing in the browser while it is computed: `server` plays a `player` whose scene `controls` change.

Read `player` first.
"""
