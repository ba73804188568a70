foreach(name splits light_basis settings cascades cascade_lattice paraboloid tight_fit projective plane_finder)
  gnomon_test(shadows/${name}_test gnomon::shadows)
endforeach()
