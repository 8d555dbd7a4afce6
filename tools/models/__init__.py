"""Encoders from elsewhere, fetched or made out of other frameworks' models; and what a model is measured by."""
