#version 450 core
// One point per surfel; its shells are made in the geometry shader.
flat out int surfel;

void main()
{
    surfel = gl_VertexID;
}
