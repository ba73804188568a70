foreach(name frames ellipsoid plan_frame camera bounds view time sun crs)
  gnomon_test(geo/${name}_test gnomon::geo)
endforeach()
# An independent UTM to compare PROJ's with.
target_link_libraries(crs_test PRIVATE PkgConfig::GEOGRAPHICLIB)
