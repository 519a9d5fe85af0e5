"""The arithmetic that both motions share, as they share IEEE 754: no formula of a motion is here.

Modules:

- `numbers`: types and elementary operations on floats and on arrays;
- `double_double`: sums, products, quotients and roots to 32 digits;
- `elementary`: sine, cosine and exponential of one set of bits on floats and on arrays;
- `decimals`: decimal arithmetic of many digits and unlimited range, and the axes of a symmetric 3×3 matrix in it.
"""
