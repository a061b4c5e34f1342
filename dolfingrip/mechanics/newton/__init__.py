"""Newton's method: tangents, factorisations, globalisation, bordered systems."""
