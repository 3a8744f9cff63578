/* usage: vdb_speck OUT.vdb COUNT EDGE_M SPECK REST: vdb_write_speck for scripts. */
#include <stdio.h>
#include <stdlib.h>

#include "vdb_writer.h"

int main(int argc, char **argv)
{
    if (argc != 6) {
        fprintf(stderr, "usage: vdb_speck OUT.vdb COUNT EDGE_M SPECK REST\n");
        return 2;
    }
    vdb_write_speck(argv[1], atoi(argv[2]), atof(argv[3]), (float)atof(argv[4]), (float)atof(argv[5]));
    return 0;
}
