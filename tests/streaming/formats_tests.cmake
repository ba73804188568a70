# The other containers of 3D Tiles 1.0, points, compression, and the samples others publish.
foreach(name i3dm cmpt pnts points meshopt gltf_extensions gltf_features samples)
  gnomon_test(streaming/${name}_test gnomon::streaming nlohmann_json::nlohmann_json)
  target_compile_definitions(${name}_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
# To encode with.
target_link_libraries(pnts_test PRIVATE PkgConfig::DRACO)
target_link_libraries(meshopt_test PRIVATE meshoptimizer::meshoptimizer)
