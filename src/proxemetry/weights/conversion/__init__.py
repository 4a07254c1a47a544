"""Networks in forms that no runtime here reads, turned into one that LiteRT runs: pure Python on the user's machine."""
