"""A bearing in the browser while it is computed: `server` plays a `player`. Read `player` first."""
