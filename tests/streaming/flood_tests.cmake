# Flood results on grids and at points, and the surface that is shown of any.
foreach(name flood point_flood water_surface)
  gnomon_test(streaming/${name}_test gnomon::streaming PkgConfig::NETCDF PkgConfig::GDAL)
  target_compile_definitions(${name}_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
