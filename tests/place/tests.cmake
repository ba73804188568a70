# Tests of the built-in place. place_streaming_test opens it with gnomon's own reader.
foreach(name plan shape flight write)
  gnomon_test(place/place_${name}_test gnomon::place nlohmann_json::nlohmann_json)
endforeach()
gnomon_test(place/place_streaming_test gnomon::place gnomon::streaming)
