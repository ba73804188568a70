#include "viewer/commands.h"

int main(int argc, char** argv) {
    return gnomon::runCommandLine(std::vector<std::string>(argv + (argc > 0 ? 1 : 0), argv + argc));
}
