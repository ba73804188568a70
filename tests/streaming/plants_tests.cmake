# Tests of what grows and what is put up on the ground: trees and barriers.
foreach(name trees trees_shape barriers barriers_plan attribute_lookup)
  gnomon_test(streaming/${name}_test gnomon::streaming)
endforeach()
