"""The command line, one file a command; `main` gathers them, `arguments` says what several take."""
