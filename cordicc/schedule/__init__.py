"""Scheduling: when every operation starts and on which unit, and the FIFOs that make its operands meet.

`request` turns what the user asks into goals, which `solver` meets; `delays` turns a schedule into FIFO
segments, `binding` and `control` give operations their units and units their control words, `place` does all
this to a plan.  `bare` schedules graphs from elsewhere, and `verify_bare` checks the result.
"""
