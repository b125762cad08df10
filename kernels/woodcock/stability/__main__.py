from woodcock.stability.cases import CASES
from woodcock.stability.children import serve

serve(CASES)
