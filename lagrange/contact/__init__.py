"""Contact of a roller or ball with a raceway: laws, Hertz's theory, dampers.

A law that time loops compile too (`damping.ContactDamping.coefficient`) is called with arrays, with one contact's
numbers, and with eight contacts at once. It may use arithmetic and comparisons; not `if`, powers or other functions.
"""
