"""The search over alternatives: cost, dominance, the choice, and the graph that is made of it."""
