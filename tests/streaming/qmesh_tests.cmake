# Pictures and polygons painted on terrain, and quantized meshes.
foreach(name drape drape_polygons quantized_mesh quantized_mesh_tile quantized_pyramid)
  gnomon_test(streaming/${name}_test gnomon::streaming PkgConfig::GDAL ZLIB::ZLIB nlohmann_json::nlohmann_json)
  target_compile_definitions(${name}_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
