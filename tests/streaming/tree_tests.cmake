foreach(name source tileset subtree selection loader tree_data)
  gnomon_test(streaming/${name}_test gnomon::streaming)
endforeach()
target_compile_definitions(tree_data_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
