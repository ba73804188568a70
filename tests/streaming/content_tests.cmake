# Tests of decoding one tile's content. glb_builder.h makes their fixtures.
foreach(name mesh clean gltf content draco image real_content)
  gnomon_test(streaming/${name}_test gnomon::streaming nlohmann_json::nlohmann_json)
  target_compile_definitions(${name}_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
target_link_libraries(draco_test PRIVATE PkgConfig::DRACO) # to encode with
