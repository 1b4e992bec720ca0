// Holds the precompiled header that all translation units with deal.II share.
