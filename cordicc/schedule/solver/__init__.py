"""The scheduling problem as data, and the algorithms that solve it.

`scheduling_problem` is the question and the answer, `goals` what is minimised, `engine` the solver over all.
Heuristics are `modulo_list`, `shift` and, by the constraint program, `neighbourhoods`; bounds are
`latency_bounds` and `cuts`.  `fifo_lp` is a linear program, exact at initiation interval 1.  `cp_search`
proves by the constraint program, of which `cp_program` holds starts and units, `fifo_entries` the FIFO words
and `cp_objective` the goals.
"""
