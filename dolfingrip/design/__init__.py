"""The design loop: design space, campaigns, their store, and what is learnt from them."""
