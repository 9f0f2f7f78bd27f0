"""Scheduling: when every operation starts, and the FIFOs that make its operands meet.

`problem` is the question and the answer as data, `fifo_lp` the exact solver for initiation
interval 1, `delays` turns a schedule into FIFO segments, `verify` checks a finished plan.
"""
