"""Encoders from elsewhere: fetched ready-made, or made out of other frameworks' models."""
