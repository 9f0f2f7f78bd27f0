"""From the equations to the cheapest unit operations that compute them, proven equal.

`passes` make one certain realisation; `rules` add alternatives, on the values of `exact`; `search` takes
the cheapest, and an accuracy gate decides between the two.
"""
