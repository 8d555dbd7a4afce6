"""One run from an empty map to found objects, in three real processes, judged against the truth."""
