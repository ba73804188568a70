foreach(name source tileset subtree selection selection_reference loader made_tiles tree_data)
  gnomon_test(streaming/${name}_test gnomon::streaming)
  # GCC 12 takes "text" + std::string for overlapping memory (its bug 105651).
  target_compile_options(${name}_test PRIVATE -Wno-restrict)
endforeach()
target_compile_definitions(tree_data_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
