"""Contact of a roller or ball with a raceway: laws, Hertz's theory, dampers."""
