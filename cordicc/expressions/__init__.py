"""From text to expression trees: lexer, grammar, hints for what cannot be read. Text is never evaluated."""
