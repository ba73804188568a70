# The list of design/HOSTILE.md, item by item; README.md tells which test is which item's.
add_library(hostile_support STATIC hostile/confined.cpp hostile/families.cpp
  hostile/family_files.cpp hostile/mutation.cpp hostile/bombs.cpp)
gnomon_settings(hostile_support)
target_link_libraries(hostile_support PUBLIC gnomon::frame gnomon::streaming PkgConfig::DRACO
  PkgConfig::GDAL PkgConfig::OPENIMAGEIO meshoptimizer::meshoptimizer nlohmann_json::nlohmann_json ZLIB::ZLIB GTest::gtest)
target_compile_definitions(hostile_support PUBLIC GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
foreach(name gltf pictures tileset sweep confined)
  gnomon_test(hostile/${name}_hostile_test hostile_support)
endforeach()
gnomon_test(hostile/program_hostile_test hostile_support)
target_compile_definitions(program_hostile_test PRIVATE GNOMON_PROGRAM="$<TARGET_FILE:gnomon>")
add_dependencies(program_hostile_test gnomon)
gnomon_test(hostile/gpu_hostile_gl_test hostile_support gnomon::render PkgConfig::EPOXY)
gnomon_test(hostile/mesh_flood_hostile_test hostile_support PkgConfig::NETCDF)
gnomon_test(hostile/list_hostile_test gnomon::geo)
target_compile_definitions(list_hostile_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
