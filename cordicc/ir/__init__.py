"""The intermediate representation: problems, graphs of operations, their printed form, facts about both."""
