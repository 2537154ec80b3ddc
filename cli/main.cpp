#include "cli/program.h"

int main(int argc, char** argv) { return lumenfarm::run_program(argc, argv); }
