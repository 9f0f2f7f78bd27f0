"""How many bits each value gets: binary points, guard bits, words for an allowed error."""
