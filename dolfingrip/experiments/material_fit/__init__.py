"""Laws of rubber fitted to coupons in uniaxial, planar and equibiaxial tension."""
