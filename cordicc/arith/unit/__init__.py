"""The CORDIC arithmetic unit (CAU), standard and implicit: passes, bounds, size; a target's arithmetic."""
