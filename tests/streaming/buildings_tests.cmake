# Features as people keep them, and buildings made of them.
foreach(name features cityjson buildings buildings_tiles real_buildings triangulate)
  gnomon_test(streaming/${name}_test gnomon::streaming PkgConfig::GDAL)
  target_compile_definitions(${name}_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
