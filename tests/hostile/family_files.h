// The good files of families.h, made by code.
#pragma once

#include "tests/viewer/files.h"

#include <fstream>
#include <string>

namespace gnomon::test {

std::string gltfText(); // with its buffer in a data: uri
std::string b3dmText(); // with feature and batch table
std::string dracoGlb(bool edgebreaker);
std::string i3dmText(); // with scales, directions, batch table
std::string pntsText(); // with colours, normals, batch table
std::string pntsDracoText();
std::string cmptText();     // of the three, one of them in a cmpt of its own
std::string meshoptText();  // vertices and indices
std::string metadataText(); // numbers, texts and arrays for two features
// A JPEG or WebP of some kilobytes. Made in a child process: the library starts threads.
std::string encodedPicture(const std::string& format);
std::string tilesetText();     // everything a tile may say
std::string implicitTileset(); // a quadtree with subtrees of 3 levels
std::string binarySubtreeText();
std::string jsonSubtreeText();
std::string quantizedText(); // with all extensions
std::string gzippedText(const std::string& text);
std::string layerText();
std::string cameraPathText();
std::string kmlTourText();
std::string sceneText();
std::string lampsText();
std::string cityJsonText();
std::string csvText();
std::string geoJsonText();

// One file in a folder of its own, written again and again.
class OneFile {
  public:
    explicit OneFile(const std::string& name) : path_(folder_ / name) {}
    void write(const std::string& text) const {
        std::ofstream(path_, std::ios::binary | std::ios::trunc) << text;
    }
    const std::string& path() const { return path_; }

  private:
    Folder folder_;
    std::string path_;
};

} // namespace gnomon::test
