#version 450 core
// A surfel as it is to be seen: its number alone.
out int number;

void main()
{
    number = gl_VertexID;
    gl_Position = vec4(0.0);
}
