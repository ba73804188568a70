# Tiles from web servers. The servers are loopback's own, so a proxy of whoever runs the tests must
# not be asked for them: each test sees to that itself.
foreach(name http_url http_cache http_client http_policy)
  gnomon_test(streaming/${name}_test gnomon::streaming gnomon_fault_server PkgConfig::SQLITE)
  target_compile_options(${name}_test PRIVATE -Wno-restrict)
  target_compile_definitions(${name}_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
gnomon_test(streaming/http_terrain_test gnomon::streaming gnomon_fault_server PkgConfig::GDAL ZLIB::ZLIB nlohmann_json::nlohmann_json)
target_compile_options(http_terrain_test PRIVATE -Wno-restrict)
target_compile_definitions(http_terrain_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
gnomon_test(viewer/web_input_test gnomon::command gnomon_fault_server nlohmann_json::nlohmann_json)
target_compile_options(web_input_test PRIVATE -Wno-restrict)
target_compile_definitions(web_input_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
