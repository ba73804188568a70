foreach(name context handles program gpu_timer visibility)
  gnomon_test(render/${name}_gl_test gnomon::render PkgConfig::EPOXY)
endforeach()
