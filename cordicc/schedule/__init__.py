"""Scheduling: when every operation starts and on which unit, and the FIFOs that make its operands meet.

`problem` is the question and the answer as data, `goals` what is minimised, `engine` the solver over all:
`modulo_list` and `shift` are its heuristics, `bounds` and `cuts` its bounds, `exact` the constraint
program, `fifo_lp` the linear program that is exact at initiation interval 1.  `request` turns what the
user asks into goals, `binding` and `control` give operations their units and units their control words,
`delays` turns a schedule into FIFO segments, `place` does all this to a plan, `assemble` makes the plan of
a graph.  `bare` schedules graphs from elsewhere.  `verify` and `verify_bare` check the results.
"""
