"""The design loop: design space, campaigns, their store, surrogates and optima."""
