"""The plan as typed, frozen data; its file; what is checked and verified of it; how it is assembled."""
