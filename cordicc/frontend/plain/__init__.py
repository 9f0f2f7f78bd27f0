"""Sugar removed: vectors, frames and branches become plain equations of one name each."""
