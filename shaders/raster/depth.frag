// Shadow maps keep only depth.
void main() {
}
