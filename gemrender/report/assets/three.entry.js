// What the report uses of three.js, the entry of the bundle three.min.js. To make it anew, in an empty folder:
//
//     npm install three@0.187.0 esbuild@0.28.2
//     npx esbuild three.entry.js --bundle --minify --format=iife --global-name=THREE \
//         --charset=ascii --legal-comments=eof --outfile=three.min.js
export {
    BackSide,
    BufferAttribute,
    BufferGeometry,
    DoubleSide,
    FrontSide,
    Mesh,
    MeshBasicMaterial,
    OrthographicCamera,
    Scene,
    ShaderMaterial,
    Vector3,
    WebGLRenderer,
} from 'three';
export { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
export { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
export { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
