# Terrain from rasters.
foreach(name height_scan raster terrain_place terrain terrain_tiles terrain_look)
  gnomon_test(streaming/${name}_test gnomon::streaming PkgConfig::GDAL)
  target_compile_definitions(${name}_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
gnomon_test(bench/skirts_test gnomon::bench)
