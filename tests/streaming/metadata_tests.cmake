# Tests of what tiles tell of the things in them, and of the tileset features nobody else tests.
foreach(name batch_table property_table validator_samples tree_features)
  gnomon_test(streaming/${name}_test gnomon::streaming nlohmann_json::nlohmann_json)
  target_compile_definitions(${name}_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  # GCC 12 takes "text" + std::string for overlapping memory (its bug 105651).
  target_compile_options(${name}_test PRIVATE -Wno-restrict)
endforeach()
foreach(name feature_at_test pick_gl_test projected_tileset_test)
  gnomon_test(viewer/${name} gnomon::frame nlohmann_json::nlohmann_json)
  target_compile_definitions(${name} PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
