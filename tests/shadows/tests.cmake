foreach(name splits light_basis settings cascades cascade_lattice)
  gnomon_test(shadows/${name}_test gnomon::shadows)
endforeach()
