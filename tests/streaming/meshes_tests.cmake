# Flood results on meshes. mesh_flood_support.h writes small NetCDF files with libnetcdf.
foreach(name mesh_flood mesh_formats real_mesh_flood)
  gnomon_test(streaming/${name}_test gnomon::streaming PkgConfig::NETCDF)
  target_compile_definitions(${name}_test PRIVATE GNOMON_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endforeach()
